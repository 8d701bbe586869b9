"""What is found out about a mesh and its colours."""
