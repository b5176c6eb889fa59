"""Interactive page in the browser that shows the motion of a rotor.

The page sends questions (`messages`), a process answers them (`workers`, through `queues`), and the
answers return as labelled arrays. The panels show a `Node` of a rotor (`cases`), of
which one disc has one. `motion` fills the panels of one run, `run_ups`
those of a run-up, `responses` and `whirls` those over the speed, and `starts` the basins.
`archives` shows what is in an archive, `opening` tells what is in a file, `measured` analyses one,
and `words` makes verdicts, sentences and sheets. `server` admits only the page on this machine.
`files` writes files to save, and a page that needs no server. The page itself is in the folder
``page``.
"""
