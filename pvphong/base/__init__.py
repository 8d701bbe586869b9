"""What every other package stands on: checks of arguments, array types, files, vectors, exact sums."""
