"""The simulator: flight, contact, and the loop from event to event.

*Decide the mode at the start; integrate inside the mode until an event may have occurred;
look for a crossing that the step hid; polish the event; record it; restart in the other
mode.* Each of these steps is a function of `loop`, `flight` or `contact_phase`.
"""
