"""The tables of the index.  All but three of them repeat what the folders say.

Only here are the secrets of links (an export of a case must hold no passcode's hash, as six digits are guessed
offline), when links were opened, sessions that were ended, and the order of fits of one moment.
Another VERSION means another form: the three tables are copied if they can be read, the rest is made again.
"""

VERSION = 5
ONLY_HERE = ("link_secrets", "openings", "ended_sessions")

TABLES = """
CREATE TABLE meta (key TEXT PRIMARY KEY, value TEXT NOT NULL) WITHOUT ROWID;
CREATE TABLE cases (
    place INTEGER PRIMARY KEY AUTOINCREMENT,  -- order of arrival here, by which pages go on
    id TEXT NOT NULL UNIQUE,
    code TEXT NOT NULL,
    code_key TEXT NOT NULL,       -- what codes are sorted by
    code_search TEXT NOT NULL,    -- what they are searched by
    created_at TEXT NOT NULL,
    first_scan TEXT NOT NULL,     -- when the first of its scans came; empty without any
    plan INTEGER NOT NULL,        -- version
    planned TEXT NOT NULL,        -- what is planned, in short, JSON
    owner TEXT,                   -- the group that owns the patient
    stamp INTEGER NOT NULL        -- of the folder that was read, ns
);
CREATE INDEX cases_by_code ON cases (code_key, place DESC);
CREATE INDEX cases_by_deletion ON cases (first_scan, place DESC);
CREATE INDEX cases_of_owner ON cases (owner, place DESC);
CREATE TABLE scans (
    id TEXT PRIMARY KEY,
    patient TEXT NOT NULL,
    created_at TEXT NOT NULL,
    stance TEXT NOT NULL,         -- as proposed
    kind TEXT NOT NULL,           -- surface, or image, also for a label map
    sha256 TEXT NOT NULL,
    announced_at TEXT             -- its deletion by age
) WITHOUT ROWID;
CREATE INDEX scans_of_case ON scans (patient, created_at, id);
CREATE INDEX scans_newest ON scans (created_at, id);
CREATE TABLE fits (
    place INTEGER PRIMARY KEY AUTOINCREMENT,  -- order among those of one moment
    id TEXT NOT NULL UNIQUE,
    patient TEXT NOT NULL,
    scan TEXT NOT NULL,
    asked_at TEXT NOT NULL,
    state TEXT NOT NULL,
    verdict TEXT,
    line_error_mm REAL,
    stance TEXT,                  -- as decided at its start
    predicted_from TEXT,
    asked_stance TEXT NOT NULL,
    key_sha256 TEXT,
    request_sha256 TEXT
);
CREATE INDEX fits_of_case ON fits (patient);
CREATE INDEX fits_of_scan ON fits (scan, asked_at, place);
CREATE INDEX fits_waiting ON fits (asked_at, place) WHERE state = 'queued';
CREATE INDEX fits_of_key ON fits (key_sha256) WHERE key_sha256 IS NOT NULL;
CREATE INDEX predictions ON fits (predicted_from) WHERE predicted_from IS NOT NULL;
CREATE TABLE links (
    id TEXT PRIMARY KEY,
    patient TEXT NOT NULL,
    scan TEXT NOT NULL,
    fit TEXT NOT NULL,
    ends_at TEXT NOT NULL,        -- empty: it was revoked
    shown INTEGER NOT NULL        -- 0: nothing any more
) WITHOUT ROWID;
CREATE INDEX links_of_case ON links (patient);
CREATE TABLE link_secrets (
    link TEXT PRIMARY KEY,
    token_sha256 TEXT NOT NULL UNIQUE,
    passcode_hash TEXT,
    wrong INTEGER NOT NULL DEFAULT 0,
    wrong_at TEXT,
    forgiven INTEGER NOT NULL DEFAULT 0
) WITHOUT ROWID;
CREATE TABLE openings (id INTEGER PRIMARY KEY, link TEXT NOT NULL, opened_at TEXT NOT NULL, visit_hmac TEXT);
CREATE INDEX openings_of_link ON openings (link);
CREATE INDEX openings_of_visit ON openings (visit_hmac);
CREATE TABLE ended_sessions (id_sha256 TEXT PRIMARY KEY, ended_at TEXT NOT NULL) WITHOUT ROWID;
"""
