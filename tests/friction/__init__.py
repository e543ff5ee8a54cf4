"""An equation with friction: kicks and criteria."""
