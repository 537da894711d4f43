-- Several processes on one database: who works on which flight, and what they tell each other.

-- A process that works on flights. Its writes hold the row (FOR KEY SHARE), so that whoever deletes
-- it waits for them, and later ones are refused.
CREATE TABLE workers (
  token bigint GENERATED ALWAYS AS IDENTITY PRIMARY KEY,
  expires_at timestamptz NOT NULL             -- end of its lease
);

CREATE TABLE claims (
  flight_id text COLLATE "C" PRIMARY KEY REFERENCES flights ON DELETE CASCADE,
  token bigint REFERENCES workers,            -- NULL: nobody works on it
  num_lost bigint NOT NULL DEFAULT 0          -- workers in a row that ended without a word
);
CREATE INDEX claims_by_worker ON claims (token) WHERE token IS NOT NULL;

-- Events that processes tell each other. The row of versions orders their numbers by commit.
CREATE TABLE told_events (
  number bigint PRIMARY KEY,
  origin text COLLATE "C" NOT NULL,           -- the process that tells
  type text NOT NULL,
  flight_id text COLLATE "C" NOT NULL,
  data text NOT NULL,                         -- JSON
  told_at timestamptz NOT NULL DEFAULT now()
);
CREATE INDEX told_events_by_time ON told_events (told_at);
INSERT INTO versions VALUES ('events', 0);
