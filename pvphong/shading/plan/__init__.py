"""Which effects a scene needs.

In reading order: `plan` is what a caller gets, runs and prints; `effects` are all effects, each with how it is left out
and what is then said of it, a light that is left out among them; `draft` is the equation that they rewrite in turn, and
`bounds` says how wrong it gets by that.
"""
