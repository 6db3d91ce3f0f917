"""One module per library; each is imported only in the environment that has the library."""
