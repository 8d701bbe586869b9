"""VTK's lighting: its lights both ways, its shader as an oracle, what it cannot say."""
