"""Systems of equations beyond one verdict."""
