"""The instrument seen from the host: a client over the serial link, captures in arrays and files, and its verbs."""
