"""The JSON shapes of requests and answers: one module a resource; source of OpenAPI and of the page's types."""
