"""Pictures, drawn with matplotlib. Functions named draw_... that take words are called by the program: see __main__.py."""
