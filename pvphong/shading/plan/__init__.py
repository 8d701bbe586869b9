"""Which effects a scene needs.

`plan.py` is the Plan; `effects.py` lists all effects in their order; `draft.py` says what an effect is and gets to see;
`bounds.py` bounds errors; the others are the effects, by what they belong to: lights, light from all around (`sky`),
reflection, viewer, surface, and what stands before it (`screens`).
"""
