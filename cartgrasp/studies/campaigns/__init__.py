"""Campaigns: many closed-loop runs of drawn carts, or many logs, over cores or a cluster."""
