"""mcsim.allan"""
