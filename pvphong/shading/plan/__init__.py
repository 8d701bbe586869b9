"""Effects that a scene needs, and the equation without the others.

In reading order: `plan` is the result that callers run and print; `effects` are all effects, with the rules by which
each is removed and the reasons why it is on or off; `lights` has bounds on each kind of light and cheaper replacements;
`state` is the equation that effects rewrite one after the other, and `bounds` are bounds on the colour errors.
"""
