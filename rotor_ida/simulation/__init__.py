"""The simulator: flight, contact, and the loop that goes from event to event.

*Decide the mode at the start; integrate inside the mode until something may have happened;
look for a crossing that the step hid; polish the event; record it; restart in the other
mode.* Each of these steps is a function of `loop`, `flight` or `contact_phase`.
"""
