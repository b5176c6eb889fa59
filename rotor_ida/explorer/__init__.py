"""A page in the browser that shows what a rotor does while its sliders move.

A page asks (`messages`), a process answers (`workers`, by way of `queues`), and the answer goes
back as labelled arrays. What is in an answer: `motion` (one run), `run_ups`, `responses` (what the
rotor settles on), `starts` (the basin) and `measured` (a dropped file), in words
`words`. `server` lets the page of this machine in and nobody else; `files` gives files to keep, and
a page that needs no server. The page itself is in the folder ``page``.
"""
