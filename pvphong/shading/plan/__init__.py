"""Plans: the effects that a scene needs, and the equation without the others.

In reading order:

- `plan`: the result, which callers run and print
- `effects`: all effects, with the rules that remove each, and the reasons why it is on or off
- `lights`: bounds on each kind of light, and cheaper lights that may replace it
- `state`: the equation, which the effects rewrite one after the other
- `bounds`: bounds on the colour errors
"""
