"""The panels of the page, a file for each subject. Each function adds one panel to the page that is being built.

Read `panel` first, a heading that unfolds its inputs. The panels are, in the order of the page, `lights`, `mix`,
`material`, `picture` with the `histogram`, `probe`, `compare` with its pictures over the view, `accuracy` and `files`.
`over_view` has the cards that lie over the view.
"""
