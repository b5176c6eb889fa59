"""The simulator: flight, contact, and the loop from event to event.

*Decide the mode at the start; integrate inside the mode until an event may have occurred;
look for a crossing that the step hid; polish the event; record it; restart in the other
mode.* The compiled core takes these steps (``core/events.h`` says which file takes which), and
`rotor_ida.simulation.witness` takes them again in plain Python.
"""
