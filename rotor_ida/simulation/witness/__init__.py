"""The slow witness of the compiled core: any rotor by CVODE or IDA, in plain Python."""
