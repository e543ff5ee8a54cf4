"""Methods and doors against one another, against kept answers, against the literature, under attack."""
