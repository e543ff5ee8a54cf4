"""What the rest of the package stands on and knows nothing of its subject."""
