"""Legacy worldfiles: reading, checking, and writing poses back."""
