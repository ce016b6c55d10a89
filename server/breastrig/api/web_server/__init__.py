"""The application on a socket: connections, bodies and threads, bounded."""
