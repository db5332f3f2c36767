"""The twin: the whole instrument in simulation, with its UART on a pseudo-terminal and an encoder on its inputs."""
