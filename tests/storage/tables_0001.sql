-- The tables of revision 0001 as SQLite has them; later revisions must turn them into those of `schema`.

CREATE TABLE alembic_version (
    version_num VARCHAR(32) NOT NULL,
    CONSTRAINT alembic_version_pkc PRIMARY KEY (version_num)
);

CREATE TABLE scans (
    id VARCHAR(32) NOT NULL,
    created_at VARCHAR(32) NOT NULL,
    file_type VARCHAR(8) NOT NULL,
    sha256 VARCHAR(64) NOT NULL,
    facts TEXT NOT NULL,
    PRIMARY KEY (id)
);

CREATE TABLE patients (
    position INTEGER NOT NULL,
    id VARCHAR(32) NOT NULL,
    code VARCHAR(60) DEFAULT '' NOT NULL,
    created_at VARCHAR(32) NOT NULL,
    version INTEGER DEFAULT '0' NOT NULL,
    code_key TEXT DEFAULT '1' NOT NULL,
    PRIMARY KEY (position),
    UNIQUE (id)
);

CREATE TABLE ended_sessions (
    id_sha256 VARCHAR(64) NOT NULL,
    ended_at VARCHAR(32) NOT NULL,
    PRIMARY KEY (id_sha256)
);

CREATE TABLE installation (
    id VARCHAR(32) NOT NULL,
    PRIMARY KEY (id)
);

CREATE TABLE file_journal (
    place VARCHAR(64) NOT NULL,
    scan VARCHAR(32) NOT NULL,
    removing BOOLEAN NOT NULL,
    PRIMARY KEY (place)
);

CREATE INDEX ix_file_journal_scan ON file_journal (scan);

CREATE TABLE landmarks (
    scan VARCHAR(32) NOT NULL,
    points_mm TEXT NOT NULL,
    certain TEXT DEFAULT '[]' NOT NULL,
    confidence TEXT DEFAULT '{}' NOT NULL,
    PRIMARY KEY (scan),
    FOREIGN KEY(scan) REFERENCES scans (id) ON DELETE CASCADE
);

CREATE TABLE cuts (
    scan VARCHAR(32) NOT NULL,
    json TEXT NOT NULL,
    PRIMARY KEY (scan),
    FOREIGN KEY(scan) REFERENCES scans (id) ON DELETE CASCADE
);

CREATE TABLE proposals (
    scan VARCHAR(32) NOT NULL,
    model_sha256 VARCHAR(64) NOT NULL,
    json TEXT NOT NULL,
    PRIMARY KEY (scan),
    FOREIGN KEY(scan) REFERENCES scans (id) ON DELETE CASCADE
);

CREATE TABLE ink (
    scan VARCHAR(32) NOT NULL,
    json TEXT NOT NULL,
    dropped TEXT DEFAULT '[]' NOT NULL,
    PRIMARY KEY (scan),
    FOREIGN KEY(scan) REFERENCES scans (id) ON DELETE CASCADE
);

CREATE TABLE scans_of_patients (
    scan VARCHAR(32) NOT NULL,
    patient VARCHAR(32) NOT NULL,
    PRIMARY KEY (scan),
    FOREIGN KEY(scan) REFERENCES scans (id) ON DELETE CASCADE,
    FOREIGN KEY(patient) REFERENCES patients (id) ON DELETE CASCADE
);

CREATE INDEX ix_scans_of_patients_patient ON scans_of_patients (patient);

CREATE TABLE plans (
    position INTEGER NOT NULL,
    patient VARCHAR(32) NOT NULL,
    version INTEGER NOT NULL,
    json TEXT NOT NULL,
    PRIMARY KEY (position),
    UNIQUE (patient, version),
    FOREIGN KEY(patient) REFERENCES patients (id) ON DELETE CASCADE
);

CREATE TABLE fits (
    id VARCHAR(32) NOT NULL,
    place INTEGER NOT NULL,
    scan VARCHAR(32) NOT NULL,
    created_at VARCHAR(32) NOT NULL,
    state VARCHAR(16) NOT NULL,
    stance VARCHAR(16) NOT NULL,
    asked_stance VARCHAR(16),
    preset VARCHAR(100) NOT NULL,
    drawing TEXT,
    landmarks_mm TEXT NOT NULL,
    certain TEXT DEFAULT '[]' NOT NULL,
    confidence TEXT DEFAULT '{}' NOT NULL,
    cuts TEXT DEFAULT '[]' NOT NULL,
    refine BOOLEAN DEFAULT 0 NOT NULL,
    start_from VARCHAR(32),
    partner VARCHAR(32),
    leads BOOLEAN DEFAULT 1 NOT NULL,
    attempt INTEGER DEFAULT '0' NOT NULL,
    last_event INTEGER NOT NULL,
    iterations INTEGER NOT NULL,
    numbers TEXT,
    reason TEXT,
    verdict VARCHAR(16),
    PRIMARY KEY (id),
    UNIQUE (place),
    FOREIGN KEY(scan) REFERENCES scans (id) ON DELETE CASCADE
);

CREATE INDEX ix_fits_state ON fits (state);

CREATE INDEX ix_fits_scan ON fits (scan);

CREATE TABLE expiring_scans (
    scan VARCHAR(32) NOT NULL,
    announced_at VARCHAR(32) NOT NULL,
    PRIMARY KEY (scan),
    FOREIGN KEY(scan) REFERENCES scans (id) ON DELETE CASCADE
);

CREATE TABLE asked_once (
    key_sha256 VARCHAR(64) NOT NULL,
    request_sha256 VARCHAR(64) NOT NULL,
    fit VARCHAR(32) NOT NULL,
    PRIMARY KEY (key_sha256),
    FOREIGN KEY(fit) REFERENCES fits (id) ON DELETE CASCADE
);

CREATE INDEX ix_asked_once_fit ON asked_once (fit);

CREATE TABLE shares (
    position INTEGER NOT NULL,
    id VARCHAR(32) NOT NULL,
    fit VARCHAR(32) NOT NULL,
    token_sha256 VARCHAR(64) NOT NULL,
    created_at VARCHAR(32) NOT NULL,
    expires_at VARCHAR(32) NOT NULL,
    revoked_at VARCHAR(32),
    scan VARCHAR(8) NOT NULL,
    notes BOOLEAN DEFAULT 0 NOT NULL,
    snapshot VARCHAR(32),
    snapshot_at VARCHAR(32),
    passcode_hash VARCHAR(300),
    wrong_passcodes INTEGER DEFAULT '0' NOT NULL,
    last_wrong_at VARCHAR(32),
    forgiven_passcodes INTEGER DEFAULT '0' NOT NULL,
    PRIMARY KEY (position),
    UNIQUE (id),
    FOREIGN KEY(fit) REFERENCES fits (id) ON DELETE CASCADE,
    UNIQUE (token_sha256)
);

CREATE INDEX ix_shares_fit ON shares (fit);

CREATE TABLE events (
    position INTEGER NOT NULL PRIMARY KEY AUTOINCREMENT,
    fit VARCHAR(32) NOT NULL,
    number INTEGER NOT NULL,
    kind VARCHAR(16) NOT NULL,
    json TEXT NOT NULL,
    UNIQUE (fit, number),
    FOREIGN KEY(fit) REFERENCES fits (id) ON DELETE CASCADE
);

CREATE INDEX events_of_kind ON events (fit, kind);

CREATE TABLE openings (
    id INTEGER NOT NULL,
    share VARCHAR(32) NOT NULL,
    opened_at VARCHAR(32) NOT NULL,
    visit_hmac VARCHAR(64),
    PRIMARY KEY (id),
    FOREIGN KEY(share) REFERENCES shares (id) ON DELETE CASCADE
);

CREATE INDEX ix_openings_visit_hmac ON openings (visit_hmac);

CREATE INDEX ix_openings_share ON openings (share);

INSERT INTO alembic_version VALUES ('0001');
