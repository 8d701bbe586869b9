"""Which effects a scene needs.

In reading order: `plan` is what a caller gets, runs and prints; `effects` are all effects, with how each is left out
and why it is on or off, from a light that is too weak to a viewer who is far away; `lights` has what is known of each
kind of light, and which cheaper one may replace it; `draft` is the equation that effects rewrite one after the other,
and `bounds` says how wrong that makes a colour.
"""
