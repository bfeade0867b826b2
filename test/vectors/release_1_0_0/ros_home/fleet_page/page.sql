BEGIN TRANSACTION;
CREATE TABLE audit (
    id INTEGER PRIMARY KEY, time REAL NOT NULL, person TEXT NOT NULL, act TEXT NOT NULL,
    details TEXT NOT NULL, ok INTEGER NOT NULL, outcome TEXT NOT NULL, mission INTEGER NOT NULL);
INSERT INTO "audit" VALUES(1,1000000002.0,'anna','send','{"mission": 7, "destinations": [4, 6]}',1,'accepted',7);
CREATE TABLE edge_hour (
    hour INTEGER NOT NULL, edge INTEGER NOT NULL, waiting REAL NOT NULL, PRIMARY KEY (hour, edge));
INSERT INTO "edge_hour" VALUES(277777,2,1.0);
CREATE TABLE favourite (name TEXT PRIMARY KEY, content TEXT NOT NULL);
INSERT INTO "favourite" VALUES('both ends','{"destinations": [1, 8]}');
CREATE TABLE robot_hour (
    hour INTEGER NOT NULL, robot TEXT NOT NULL, distance REAL NOT NULL, busy REAL NOT NULL,
    waiting REAL NOT NULL, watched REAL NOT NULL, PRIMARY KEY (hour, robot));
INSERT INTO "robot_hour" VALUES(277777,'a',2.0,4.0,1.0,5.0);
CREATE INDEX audit_by_mission ON audit (mission);
COMMIT;
