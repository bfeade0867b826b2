"""The body on its floor: poses, free space, ways, and the base that drives them. mm and degrees."""
