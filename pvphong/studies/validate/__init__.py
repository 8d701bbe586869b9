"""pvphong's colours against VTK's own shader."""
