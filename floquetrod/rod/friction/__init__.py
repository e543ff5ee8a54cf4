"""A rod held by friction: which modes a kick destabilises, and the smallest such kick."""
