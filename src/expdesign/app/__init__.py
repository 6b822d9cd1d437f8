"""The functions of the package, the commands made of them, engines for several processes."""
