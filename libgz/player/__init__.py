"""Player's TCP protocols, served from the interfaces of a running server: for client programs of 2004 to 2008."""
