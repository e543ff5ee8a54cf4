"""The published study."""
