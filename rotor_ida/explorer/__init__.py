"""A page in the browser that shows what a rotor does while its sliders move.

A page asks (`questions`), a process answers (`workers`, by way of `lanes`), and the answer goes
back as labelled arrays (`answers`). What is in an answer is told in `motion`, `passage`,
`responses` and `starts`, in words in `words`. `server` lets the page of this machine in and nobody
else; `saving` gives files to keep, `recording` a page that needs no server. The page itself is in
the folder ``page``.
"""
