"""The body on its floor: poses, free space, paths, and the base that drives. mm and degrees."""
