"""Exact results: synchronous whirls, their folds and stability, free flight and vibration.

Nothing here knows the simulator, and the simulator knows nothing of this: each is the
other's independent witness.
"""
