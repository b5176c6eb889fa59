"""The plain-Python reference: the event loop over the public interface of scikit-sundae.

It shares with the compiled core nothing but the stated model, and takes the same steps some twenty
times slower. It is what ``backend="python"`` runs.
"""
