"""Plane strain compression of a specimen with a weak element: the biaxial test of the paper's section 5."""
