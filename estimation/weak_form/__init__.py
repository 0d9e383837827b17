"""Momentum balances in weak form: what wrenches and motion of a log say about a cart, with nothing differentiated."""
