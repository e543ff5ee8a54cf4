"""The methods, one file each: `method(equation, ...) -> Stability`.  None calls another."""
