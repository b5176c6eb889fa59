"""CVODE and IDA: the SUNDIALS libraries, called from Python and from compiled code."""
