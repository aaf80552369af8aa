"""What the command line and programs of others call: its functions are public names of mcsim."""
