"""What a person does with a graph, told apart from ROS and from windows."""
