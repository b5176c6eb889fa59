"""Interactive page in the browser that shows the motion of a rotor.

The page sends questions (`messages`), a process answers them (`workers`, through `queues`), and the
answers return as labelled arrays. Modules for the answers about one disc: `motion` (one run),
`run_ups`, `responses` (the settled response) and `starts` (basins). `cases` reads and runs what is
in the file of a rotor system or a result, and `systems` fills the same panels from it. `opening`
tells what is in a file, `measured` analyses one, and `words` makes verdicts, sentences and sheets.
`server` admits only the page on this machine. `files` writes files to save, and a page that needs
no server. The page itself is in the folder ``page``.
"""
