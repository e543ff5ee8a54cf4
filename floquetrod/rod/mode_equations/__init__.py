"""From a rod and a load to the equations of its modes."""
