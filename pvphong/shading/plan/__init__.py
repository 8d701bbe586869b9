"""Which effects a scene needs.

In reading order: `plan` is what a caller gets, runs and prints; `effects` are all effects, with how each is left out
and why it is on or off, from a light that is too weak to a viewer who is far away; `draft` is the equation that they
rewrite one after the other, and `bounds` says how wrong that makes a colour.
"""
