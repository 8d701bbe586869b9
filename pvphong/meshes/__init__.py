"""PyVista data in and out: surfaces, cells, files, pictures."""
