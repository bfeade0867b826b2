-- A journal as version 1.0.0 left it: a has driven to edge 2, and is to visit 4 and 6; b was taken out of service.
BEGIN TRANSACTION;
CREATE TABLE change (
    time REAL NOT NULL, serial INTEGER NOT NULL, state INTEGER NOT NULL, robot TEXT NOT NULL,
    reached INTEGER NOT NULL, reason TEXT NOT NULL, requested_by TEXT NOT NULL DEFAULT '');
INSERT INTO "change" VALUES(1000000002.0,1,0,'',0,'','');
INSERT INTO "change" VALUES(1000000002.0,2,0,'',0,'','');
INSERT INTO "change" VALUES(1000000002.1,1,1,'a',0,'','');
INSERT INTO "change" VALUES(1000000002.1,2,2,'b',1,'','');
CREATE TABLE graph (
        one INTEGER PRIMARY KEY CHECK (one = 1), elements TEXT NOT NULL);
INSERT INTO "graph" VALUES(1,'[[[1, 0.0, 0.0, 0.0, 0.0, "", "", false, null], [2, 2.0, 0.0, 0.0, 0.0, "", "", false, null], [3, 4.0, 0.0, 0.0, 0.0, "", "", false, null], [4, 6.0, 0.0, 0.0, 0.0, "", "", false, null], [5, 8.0, 0.0, 0.0, 0.0, "", "", false, null], [6, 10.0, 0.0, 0.0, 0.0, "", "", false, null], [7, 12.0, 0.0, 0.0, 0.0, "", "", false, null], [8, 14.0, 0.0, 0.0, 0.0, "", "", false, null]], [[1, 1, 2, "line", 0.0, 0.0, 1.0, 1.0], [2, 2, 3, "line", 0.0, 0.0, 1.0, 1.0], [3, 3, 4, "line", 0.0, 0.0, 1.0, 1.0], [4, 4, 5, "line", 0.0, 0.0, 1.0, 1.0], [5, 5, 6, "line", 0.0, 0.0, 1.0, 1.0], [6, 6, 7, "line", 0.0, 0.0, 1.0, 1.0], [7, 7, 8, "line", 0.0, 0.0, 1.0, 1.0]]]');
CREATE TABLE mission (
    serial INTEGER PRIMARY KEY, request_id INTEGER NOT NULL, request TEXT NOT NULL,
    state INTEGER NOT NULL, robot TEXT NOT NULL, reached INTEGER NOT NULL, reason TEXT NOT NULL, stamp REAL NOT NULL DEFAULT 0.0, changed REAL NOT NULL DEFAULT 0.0);
INSERT INTO "mission" VALUES(1,7,'{"id": 7, "destinations": [4, 6], "robot_type": "", "robot": "a", "priority": 0, "dwells": [], "stamp": 0.0, "requested_by": ""}',1,'a',0,'',0.0,1000000002.1);
INSERT INTO "mission" VALUES(2,8,'{"id": 8, "destinations": [8], "robot_type": "", "robot": "b", "priority": 0, "dwells": [], "stamp": 0.0, "requested_by": ""}',2,'b',1,'',0.0,1000000002.1);
CREATE TABLE robot (name TEXT PRIMARY KEY, memory TEXT NOT NULL);
INSERT INTO "robot" VALUES('a','{"route_id": 1, "track": [1, 2], "done": 1, "bases": [[1, 0, 0]], "over": false, "ended": [], "stopping": false, "shortened": null, "place": [2, 0, 0.0], "cleared": [1, 0.0], "tail": [], "evidence": [[], [], [], 0.0, [2.0, 0.0], false, false], "stamp": 4.200000000000001, "withdrawn": null, "acknowledged": [1], "outage": null, "why": "", "halted": false, "resting": false, "dock": null, "charge": null, "type": ["agv", 0.4, 1.0, 0.0]}');
INSERT INTO "robot" VALUES('b','{"route_id": 2, "track": [], "done": 0, "bases": [[2, 0, 0]], "over": true, "ended": [], "stopping": false, "shortened": null, "place": [8, 0, 0.0], "cleared": [0, 0.0], "tail": [], "evidence": [[], [], [], 0.0, [14.0, 0.0], false, false], "stamp": 5.399999999999997, "withdrawn": null, "acknowledged": [0, 2], "outage": "OUT_OF_SERVICE", "why": "it was taken out of service", "halted": false, "resting": false, "dock": null, "charge": null, "type": ["agv", 0.4, 1.0, 0.0]}');
CREATE TABLE stay (serial INTEGER PRIMARY KEY, began REAL NOT NULL);
CREATE TABLE value (name TEXT PRIMARY KEY, number INTEGER NOT NULL);
INSERT INTO "value" VALUES('route_id',10000);
CREATE INDEX mission_by_state ON mission (state);
CREATE INDEX change_by_serial ON change (serial);
CREATE INDEX mission_by_request ON mission (request_id, stamp);
CREATE INDEX mission_by_change ON mission (changed);
PRAGMA user_version = 3;
COMMIT;
