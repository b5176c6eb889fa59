"""The plain-Python reference: the event loop over the public interface of scikit-sundae.

Its event loop shares with the compiled core nothing but the stated model, and takes tens of times
as long. It is what ``backend="python"`` runs.
"""
