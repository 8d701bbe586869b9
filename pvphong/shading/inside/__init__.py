"""What colours do between vertices: `interpolation` finds where they are off, `splitting` splits triangles there."""
