"""What is seen: lights, viewer and light model as one value."""
