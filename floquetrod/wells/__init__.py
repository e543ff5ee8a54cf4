"""The path of a well: stations of a survey, and the arcs between them."""
