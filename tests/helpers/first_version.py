"""What the first version of BreastRig has left in its database."""

# The tables of the first version, and a scan with landmarks and a fit with one event in them.
FIRST_VERSION = """
CREATE TABLE scans (id VARCHAR(32) NOT NULL, created_at VARCHAR(32) NOT NULL, file_type VARCHAR(8) NOT NULL,
    sha256 VARCHAR(64) NOT NULL, facts TEXT NOT NULL, PRIMARY KEY (id));
CREATE TABLE landmarks (scan VARCHAR(32) NOT NULL, points_mm TEXT NOT NULL, PRIMARY KEY (scan),
    FOREIGN KEY(scan) REFERENCES scans (id) ON DELETE CASCADE);
CREATE TABLE fits (id VARCHAR(32) NOT NULL, place INTEGER NOT NULL, scan VARCHAR(32) NOT NULL,
    created_at VARCHAR(32) NOT NULL, state VARCHAR(16) NOT NULL, stance VARCHAR(16) NOT NULL,
    preset VARCHAR(100) NOT NULL, drawing VARCHAR(100), landmarks_mm TEXT NOT NULL, last_event INTEGER NOT NULL,
    iterations INTEGER NOT NULL, numbers TEXT, reason TEXT, PRIMARY KEY (id), UNIQUE (place),
    FOREIGN KEY(scan) REFERENCES scans (id) ON DELETE CASCADE);
CREATE INDEX ix_fits_scan ON fits (scan);
CREATE INDEX ix_fits_state ON fits (state);
CREATE TABLE events (position INTEGER NOT NULL PRIMARY KEY AUTOINCREMENT, fit VARCHAR(32) NOT NULL,
    number INTEGER NOT NULL, kind VARCHAR(16) NOT NULL, json TEXT NOT NULL, UNIQUE (fit, number),
    FOREIGN KEY(fit) REFERENCES fits (id) ON DELETE CASCADE);
CREATE INDEX events_of_kind ON events (fit, kind);
INSERT INTO scans VALUES ('scan-1', '2026-01-01T00:00:00.000Z', 'ply', 'abab', '{"unit": "mm"}');
INSERT INTO landmarks VALUES ('scan-1', '{"nipple_L": [1.0, 2.0, 3.0]}');
INSERT INTO fits VALUES ('fit-1', 1, 'scan-1', '2026-01-01T00:00:01.000Z', 'queued', 'auto', 'default', NULL, '{}',
    1, 0, NULL, NULL);
INSERT INTO events VALUES (7, 'fit-1', 1, 'started', '{"kind": "started"}');
"""
