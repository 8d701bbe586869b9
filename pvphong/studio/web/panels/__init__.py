"""The panels of the page, a file for each subject. Each function adds one panel to the page that is being built.

Read `panel` first; it has the frame of a panel, a heading that unfolds its inputs. The panels are, in the order of the
page, `lights`, `mix`, `material`, `camera`, `picture` with the `histogram`, `probe`, `compare` with its pictures over
the view, `files` and `accuracy`. `ask` has a tool of the panel "Lights". `stage` has the buttons of the panel "Scene"
for a stage. `over_view` has the cards over the view, `dropping` takes files that are dropped onto the page, and `help`
has the welcome and the keys.
"""
