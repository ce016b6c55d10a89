"""What goes over the wire: one module a resource, from which OpenAPI and the page's types are made."""
