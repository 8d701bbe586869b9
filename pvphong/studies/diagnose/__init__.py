"""What in a mesh will not light as it should."""
