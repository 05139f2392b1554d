<?xml version="1.0" encoding="utf-8"?>
<!DOCTYPE TS>
<TS version="2.1" language="de" sourcelanguage="en">
    <context>
        <name>App::Property</name>
        <message>
            <source>Colour of each corner</source>
            <translation>Farbe jeder Ecke</translation>
        </message>
        <message>
            <source>Comment</source>
            <translation>Kommentar</translation>
        </message>
        <message>
            <source>Coolant is on in cuts</source>
            <translation>Kühlmittel ist in Schnitten an</translation>
        </message>
        <message>
            <source>Deepest gouge after everything</source>
            <translation>Tiefste Verletzung nach allem</translation>
        </message>
        <message>
            <source>Dialects that are written besides LinuxCNC</source>
            <translation>Dialekte, die neben LinuxCNC geschrieben werden</translation>
        </message>
        <message>
            <source>Direction of the passes</source>
            <translation>Richtung der Bahnen</translation>
        </message>
        <message>
            <source>Every tolerance and limit is kept</source>
            <translation>Alle Toleranzen und Grenzen sind eingehalten</translation>
        </message>
        <message>
            <source>Faces to finish, of one body</source>
            <translation>Zu schlichtende Flächen eines Körpers</translation>
        </message>
        <message>
            <source>Fingerprint of everything that decided the result</source>
            <translation>Fingerabdruck von allem, was das Ergebnis bestimmt hat</translation>
        </message>
        <message>
            <source>From gauge point to tip</source>
            <translation>Vom Bezugspunkt bis zur Spitze</translation>
        </message>
        <message>
            <source>Height over the face at each corner, mm; negative is a gouge</source>
            <translation>Höhe über der Fläche an jeder Ecke, mm; negativ ist eine Verletzung</translation>
        </message>
        <message>
            <source>How the tool is placed</source>
            <translation>Wie das Werkzeug angestellt wird</translation>
        </message>
        <message>
            <source>Inclination along the feed, for fixed-tilt and ball</source>
            <translation>Neigung in Vorschubrichtung, für fixed-tilt und ball</translation>
        </message>
        <message>
            <source>Inclination sideways, for fixed-tilt and ball</source>
            <translation>Neigung zur Seite, für fixed-tilt und ball</translation>
        </message>
        <message>
            <source>Job of the CAM workbench</source>
            <translation>Auftrag des Arbeitsbereichs CAM</translation>
        </message>
        <message>
            <source>Job of this operation</source>
            <translation>Auftrag dieser Operation</translation>
        </message>
        <message>
            <source>Largest excess after everything</source>
            <translation>Größtes Aufmaß nach allem</translation>
        </message>
        <message>
            <source>Least distance from fixtures</source>
            <translation>Kleinster Abstand von Spannmitteln</translation>
        </message>
        <message>
            <source>Links travel this far above the part</source>
            <translation>Verbindungen laufen so hoch über dem Teil</translation>
        </message>
        <message>
            <source>Machine of the job: a change of it, or of a fixture, plans anew</source>
            <translation>Maschine des Auftrags: ändert sie sich oder ein Spannmittel, wird neu geplant</translation>
        </message>
        <message>
            <source>Model or settings have changed since</source>
            <translation>Modell oder Einstellungen haben sich seither geändert</translation>
        </message>
        <message>
            <source>Name of a built-in machine, or machine file (TOML)</source>
            <translation>Name einer mitgelieferten Maschine oder Maschinendatei (TOML)</translation>
        </message>
        <message>
            <source>Order of the passes</source>
            <translation>Reihenfolge der Bahnen</translation>
        </message>
        <message>
            <source>Passes and deviation</source>
            <translation>Bahnen und Abweichung</translation>
        </message>
        <message>
            <source>Planned time, s</source>
            <translation>Geplante Zeit, s</translation>
        </message>
        <message>
            <source>Programs by file name</source>
            <translation>Programme nach Dateiname</translation>
        </message>
        <message>
            <source>Rotation about the machine's x, then y, then z, degrees</source>
            <translation>Drehung um x, dann y, dann z der Maschine, Grad</translation>
        </message>
        <message>
            <source>Setup sheet</source>
            <translation>Einrichteblatt</translation>
        </message>
        <message>
            <source>Solids that no part of the tool may touch</source>
            <translation>Körper, die kein Teil des Werkzeugs berühren darf</translation>
        </message>
        <message>
            <source>Take part in checks and programs</source>
            <translation>An Prüfungen und Programmen teilnehmen</translation>
        </message>
        <message>
            <source>The cutter works on the other side of the faces</source>
            <translation>Der Fräser arbeitet auf der anderen Seite der Flächen</translation>
        </message>
        <message>
            <source>Tool controller of the job</source>
            <translation>Werkzeugsteuerung des Auftrags</translation>
        </message>
        <message>
            <source>What the check of the program says</source>
            <translation>Was die Prüfung des Programms sagt</translation>
        </message>
        <message>
            <source>Zero of the document in machine coordinates, all axes at zero, mm</source>
            <translation>Nullpunkt des Dokuments in Maschinenkoordinaten, alle Achsen auf null, mm</translation>
        </message>
    </context>
    <context>
        <name>trunnion</name>
        <message>
            <source>'{text}' is no feed</source>
            <translation>'{text}' ist kein Vorschub</translation>
        </message>
        <message>
            <source>'{text}' is no length</source>
            <translation>'{text}' ist keine Länge</translation>
        </message>
        <message>
            <source>--dialect=NAME, which is one of: {names}</source>
            <translation>--dialect=NAME, und zwar: {names}</translation>
        </message>
        <message>
            <source>About {axis}, deg</source>
            <translation>Um {axis}, Grad</translation>
        </message>
        <message>
            <source>Acceleration and jerk, which .fcm files lack: enter those of your machine</source>
            <translation>Beschleunigung und Ruck, die in .fcm-Dateien fehlen: die Ihrer Maschine eintragen</translation>
        </message>
        <message>
            <source>Best setup</source>
            <translation>Beste Aufspannung</translation>
        </message>
        <message>
            <source>Check the program of the job against part, machine, stock and fixtures</source>
            <translation>Das Programm des Auftrags gegen Teil, Maschine, Rohteil und Spannmittel prüfen</translation>
        </message>
        <message>
            <source>Check this job</source>
            <translation>Auftrag prüfen</translation>
        </message>
        <message>
            <source>Choose the machine of the job, and where the part stands on it</source>
            <translation>Die Maschine des Auftrags wählen, und wo das Teil auf ihr steht</translation>
        </message>
        <message>
            <source>Class (.fcm)</source>
            <translation>Klasse (.fcm)</translation>
        </message>
        <message>
            <source>Clearance</source>
            <translation>Abstand</translation>
        </message>
        <message>
            <source>Compare</source>
            <translation>Vergleichen</translation>
        </message>
        <message>
            <source>Compare tools, tolerances or machines</source>
            <translation>Werkzeuge, Toleranzen oder Maschinen vergleichen</translation>
        </message>
        <message>
            <source>Deepest gouge</source>
            <translation>Verletzung bis</translation>
        </message>
        <message>
            <source>Deviation of {label}</source>
            <translation>Abweichung von {label}</translation>
        </message>
        <message>
            <source>Dialect</source>
            <translation>Dialekt</translation>
        </message>
        <message>
            <source>Faces</source>
            <translation>Flächen</translation>
        </message>
        <message>
            <source>Feed</source>
            <translation>Vorschub</translation>
        </message>
        <message>
            <source>Finish the selected faces with five axes</source>
            <translation>Die gewählten Flächen fünfachsig schlichten</translation>
        </message>
        <message>
            <source>Five-axis finish</source>
            <translation>Fünfachsig schlichten</translation>
        </message>
        <message>
            <source>Five-axis finishing, checks with guaranteed bounds, and posts</source>
            <translation>Fünfachsiges Schlichten, Prüfungen mit garantierten Schranken, und Postprozessoren</translation>
        </message>
        <message>
            <source>Fixtures</source>
            <translation>Spannmittel</translation>
        </message>
        <message>
            <source>From a file ..</source>
            <translation>Aus Datei ..</translation>
        </message>
        <message>
            <source>Install post processor</source>
            <translation>Postprozessor einrichten</translation>
        </message>
        <message>
            <source>Largest excess</source>
            <translation>Aufmaß bis</translation>
        </message>
        <message>
            <source>Linear, mm/s2</source>
            <translation>Linear, mm/s2</translation>
        </message>
        <message>
            <source>Linear, mm/s3</source>
            <translation>Linear, mm/s3</translation>
        </message>
        <message>
            <source>Machine</source>
            <translation>Maschine</translation>
        </message>
        <message>
            <source>Machine of {label}</source>
            <translation>Maschine von {label}</translation>
        </message>
        <message>
            <source>Machines</source>
            <translation>Maschinen</translation>
        </message>
        <message>
            <source>Make trunnion a post processor of FreeCAD's own Post Process</source>
            <translation>trunnion zu einem Postprozessor von FreeCADs eigener Nachbearbeitung machen</translation>
        </message>
        <message>
            <source>Method</source>
            <translation>Verfahren</translation>
        </message>
        <message>
            <source>NOT KEPT</source>
            <translation>NICHT EINGEHALTEN</translation>
        </message>
        <message>
            <source>NOT KEPT: {problems}</source>
            <translation>NICHT EINGEHALTEN: {problems}</translation>
        </message>
        <message>
            <source>Order</source>
            <translation>Reihenfolge</translation>
        </message>
        <message>
            <source>Over</source>
            <translation>Über</translation>
        </message>
        <message>
            <source>Passes along</source>
            <translation>Bahnen längs</translation>
        </message>
        <message>
            <source>Passes of {label}</source>
            <translation>Bahnen von {label}</translation>
        </message>
        <message>
            <source>Place of the problem</source>
            <translation>Ort des Problems</translation>
        </message>
        <message>
            <source>Play the program of the operation in the browser</source>
            <translation>Das Programm der Operation im Browser abspielen</translation>
        </message>
        <message>
            <source>Post with trunnion</source>
            <translation>Mit trunnion ausgeben</translation>
        </message>
        <message>
            <source>Posts with trunnion: ten dialects for five-axis machines</source>
            <translation>Gibt mit trunnion aus: zehn Dialekte für fünfachsige Maschinen</translation>
        </message>
        <message>
            <source>Preview</source>
            <translation>Vorschau</translation>
        </message>
        <message>
            <source>Program</source>
            <translation>Programm</translation>
        </message>
        <message>
            <source>Propose the origin</source>
            <translation>Nullpunkt vorschlagen</translation>
        </message>
        <message>
            <source>Rotary, deg/s2</source>
            <translation>Drehend, Grad/s2</translation>
        </message>
        <message>
            <source>Rotary, deg/s3</source>
            <translation>Drehend, Grad/s3</translation>
        </message>
        <message>
            <source>Rotation of the workpiece about the machine's x, then y, then z</source>
            <translation>Drehung des Werkstücks um x, dann y, dann z der Maschine</translation>
        </message>
        <message>
            <source>Search the rotation of the part that suits the machine best</source>
            <translation>Die Drehung des Teils suchen, die der Maschine am besten liegt</translation>
        </message>
        <message>
            <source>Side</source>
            <translation>Seite</translation>
        </message>
        <message>
            <source>Simulate</source>
            <translation>Simulieren</translation>
        </message>
        <message>
            <source>Speed, 1/min</source>
            <translation>Drehzahl, 1/min</translation>
        </message>
        <message>
            <source>Stop</source>
            <translation>Halt</translation>
        </message>
        <message>
            <source>Summary</source>
            <translation>Übersicht</translation>
        </message>
        <message>
            <source>Take selected solids</source>
            <translation>Gewählte Körper nehmen</translation>
        </message>
        <message>
            <source>Tool</source>
            <translation>Werkzeug</translation>
        </message>
        <message>
            <source>Tool length</source>
            <translation>Länge</translation>
        </message>
        <message>
            <source>Values</source>
            <translation>Werte</translation>
        </message>
        <message>
            <source>Where the zero of the document stands in machine coordinates, with all axes at zero</source>
            <translation>Wo der Nullpunkt des Dokuments in Maschinenkoordinaten liegt, wenn alle Achsen auf null stehen</translation>
        </message>
        <message>
            <source>Write the program of the job in one of ten dialects</source>
            <translation>Das Programm des Auftrags in einem von zehn Dialekten schreiben</translation>
        </message>
        <message>
            <source>Zero at {axis}</source>
            <translation>Nullpunkt {axis}</translation>
        </message>
        <message>
            <source>acceleration and jerk are those that were entered: compare them with the parameters of the control</source>
            <translation>Beschleunigung und Ruck sind die eingetragenen: mit den Parametern der Steuerung vergleichen</translation>
        </message>
        <message>
            <source>add one to the job</source>
            <translation>dem Auftrag eines hinzufügen</translation>
        </message>
        <message>
            <source>add one with a flat, ball or bull-nose end mill</source>
            <translation>eine mit Schaft-, Kugel- oder Torusfräser hinzufügen</translation>
        </message>
        <message>
            <source>add the missing axes in the machine editor</source>
            <translation>die fehlenden Achsen im Maschineneditor ergänzen</translation>
        </message>
        <message>
            <source>allow more tilt, or take a shorter tool</source>
            <translation>mehr Neigung erlauben oder ein kürzeres Werkzeug nehmen</translation>
        </message>
        <message>
            <source>another task panel is open</source>
            <translation>ein anderes Aufgabenfeld ist offen</translation>
        </message>
        <message>
            <source>as the face asks</source>
            <translation>wie die Fläche es verlangt</translation>
        </message>
        <message>
            <source>automatic</source>
            <translation>automatisch</translation>
        </message>
        <message>
            <source>axis {name} has no direction</source>
            <translation>Achse {name} hat keine Richtung</translation>
        </message>
        <message>
            <source>ball end</source>
            <translation>Kugelkopf</translation>
        </message>
        <message>
            <source>best</source>
            <translation>beste</translation>
        </message>
        <message>
            <source>best setup</source>
            <translation>beste Aufspannung</translation>
        </message>
        <message>
            <source>check of {label}</source>
            <translation>Prüfung von {label}</translation>
        </message>
        <message>
            <source>check the part with Part &gt; Check geometry</source>
            <translation>das Teil mit Part &gt; Geometrie prüfen untersuchen</translation>
        </message>
        <message>
            <source>choose a .fcm file that the machine editor of FreeCAD wrote</source>
            <translation>eine .fcm-Datei wählen, die FreeCADs Maschineneditor geschrieben hat</translation>
        </message>
        <message>
            <source>choose a tool bit for the controller</source>
            <translation>ein Werkzeug für die Werkzeugsteuerung wählen</translation>
        </message>
        <message>
            <source>choose one of the job</source>
            <translation>eine des Auftrags wählen</translation>
        </message>
        <message>
            <source>choose one of: {names}</source>
            <translation>eines davon wählen: {names}</translation>
        </message>
        <message>
            <source>choose one with the command Machine</source>
            <translation>eine mit dem Befehl Maschine wählen</translation>
        </message>
        <message>
            <source>close it first</source>
            <translation>es zuerst schließen</translation>
        </message>
        <message>
            <source>comparing ..</source>
            <translation>vergleicht ..</translation>
        </message>
        <message>
            <source>comparison of {label}</source>
            <translation>Vergleich von {label}</translation>
        </message>
        <message>
            <source>create a job first</source>
            <translation>zuerst einen Auftrag anlegen</translation>
        </message>
        <message>
            <source>create a new job; this one can still be checked and posted</source>
            <translation>lege einen neuen Auftrag an; dieser lässt sich weiter prüfen und ausgeben</translation>
        </message>
        <message>
            <source>create it again in a job</source>
            <translation>sie in einem Auftrag neu anlegen</translation>
        </message>
        <message>
            <source>create one with the CAM workbench: Job</source>
            <translation>einen mit dem Arbeitsbereich CAM anlegen: Auftrag</translation>
        </message>
        <message>
            <source>cut the other side</source>
            <translation>andere Seite fräsen</translation>
        </message>
        <message>
            <source>diameter of the tool, mm</source>
            <translation>Durchmesser des Werkzeugs, mm</translation>
        </message>
        <message>
            <source>directions of rotation are taken as ISO 841 has them: jog each rotary by +30 degrees, and add `sense = -1` where it turns the other way</source>
            <translation>Drehrichtungen sind die nach ISO 841: jede Drehachse um +30 Grad verfahren, und `sense = -1` ergänzen, wo sie andersherum dreht</translation>
        </message>
        <message>
            <source>down to {limit}</source>
            <translation>bis {limit}</translation>
        </message>
        <message>
            <source>drawing</source>
            <translation>zeichnet</translation>
        </message>
        <message>
            <source>enter it in the machine editor</source>
            <translation>sie im Maschineneditor eintragen</translation>
        </message>
        <message>
            <source>enter the same length in all operations of the tool</source>
            <translation>in allen Operationen des Werkzeugs dieselbe Länge eintragen</translation>
        </message>
        <message>
            <source>every tolerance and limit is kept</source>
            <translation>alle Toleranzen und Grenzen sind eingehalten</translation>
        </message>
        <message>
            <source>excess, more than {limit}</source>
            <translation>Aufmaß, mehr als {limit}</translation>
        </message>
        <message>
            <source>faces of {count} bodies are selected: {labels}</source>
            <translation>Flächen von {count} Körpern sind gewählt: {labels}</translation>
        </message>
        <message>
            <source>fixed inclination</source>
            <translation>feste Neigung</translation>
        </message>
        <message>
            <source>flank</source>
            <translation>Flanke</translation>
        </message>
        <message>
            <source>give a machine file, or one of the built-in machines: {names}</source>
            <translation>eine Maschinendatei angeben oder eine der mitgelieferten Maschinen: {names}</translation>
        </message>
        <message>
            <source>give each tool a number of its own in its tool controller</source>
            <translation>jedem Werkzeug in seiner Werkzeugsteuerung eine eigene Nummer geben</translation>
        </message>
        <message>
            <source>gouge, below {limit}</source>
            <translation>Verletzung, unter {limit}</translation>
        </message>
        <message>
            <source>help: {remedy}</source>
            <translation>Hilfe: {remedy}</translation>
        </message>
        <message>
            <source>high-speed machine</source>
            <translation>Hochgeschwindigkeit</translation>
        </message>
        <message>
            <source>hobby</source>
            <translation>Hobby</translation>
        </message>
        <message>
            <source>install FreeCAD with its CAM (Path) workbench, 0.20.2 or later</source>
            <translation>FreeCAD mit dem Arbeitsbereich CAM (Path) installieren, 0.20.2 oder neuer</translation>
        </message>
        <message>
            <source>install it for the Python of FreeCAD: pip install trunnion</source>
            <translation>es für das Python von FreeCAD installieren: pip install trunnion</translation>
        </message>
        <message>
            <source>install {least} or later: pip install -U trunnion</source>
            <translation>{least} oder neuer installieren: pip install -U trunnion</translation>
        </message>
        <message>
            <source>it has to be between 0 and {most} mm</source>
            <translation>er muss zwischen 0 und {most} mm liegen</translation>
        </message>
        <message>
            <source>kept</source>
            <translation>eingehalten</translation>
        </message>
        <message>
            <source>largest excess, mm</source>
            <translation>größtes Aufmaß, mm</translation>
        </message>
        <message>
            <source>least curvature</source>
            <translation>kleinste Krümmung</translation>
        </message>
        <message>
            <source>machine</source>
            <translation>Maschine</translation>
        </message>
        <message>
            <source>machining centre</source>
            <translation>Bearbeitungszentrum</translation>
        </message>
        <message>
            <source>no</source>
            <translation>nein</translation>
        </message>
        <message>
            <source>no active operation of the job moves a tool</source>
            <translation>keine aktive Operation des Auftrags bewegt ein Werkzeug</translation>
        </message>
        <message>
            <source>no face is chosen</source>
            <translation>keine Fläche ist gewählt</translation>
        </message>
        <message>
            <source>no face is selected, but {other} of {label}</source>
            <translation>keine Fläche ist gewählt, sondern {other} von {label}</translation>
        </message>
        <message>
            <source>no rotation within the bounds fits</source>
            <translation>keine Drehung innerhalb der Schranken passt</translation>
        </message>
        <message>
            <source>no solids: {labels}</source>
            <translation>keine Körper: {labels}</translation>
        </message>
        <message>
            <source>no tool controller is chosen</source>
            <translation>keine Werkzeugsteuerung ist gewählt</translation>
        </message>
        <message>
            <source>none</source>
            <translation>keine</translation>
        </message>
        <message>
            <source>none of the modules {names} can be loaded</source>
            <translation>keines der Module {names} lässt sich laden</translation>
        </message>
        <message>
            <source>none of the objects is an operation of a job</source>
            <translation>keines der Objekte ist eine Operation eines Auftrags</translation>
        </message>
        <message>
            <source>not computed</source>
            <translation>nicht berechnet</translation>
        </message>
        <message>
            <source>not cut</source>
            <translation>nicht gefräst</translation>
        </message>
        <message>
            <source>not measured</source>
            <translation>nicht gemessen</translation>
        </message>
        <message>
            <source>nothing is selected</source>
            <translation>nichts ist gewählt</translation>
        </message>
        <message>
            <source>nothing within the bounds fits</source>
            <translation>nichts innerhalb der Schranken passt</translation>
        </message>
        <message>
            <source>now</source>
            <translation>jetzt</translation>
        </message>
        <message>
            <source>on the face</source>
            <translation>auf der Fläche</translation>
        </message>
        <message>
            <source>one way</source>
            <translation>eine Richtung</translation>
        </message>
        <message>
            <source>origin</source>
            <translation>Nullpunkt</translation>
        </message>
        <message>
            <source>passes</source>
            <translation>Bahnen</translation>
        </message>
        <message>
            <source>planning ..</source>
            <translation>plant ..</translation>
        </message>
        <message>
            <source>planning was stopped</source>
            <translation>die Planung wurde angehalten</translation>
        </message>
        <message>
            <source>post a job of the CAM workbench</source>
            <translation>einen Auftrag des Arbeitsbereichs CAM ausgeben</translation>
        </message>
        <message>
            <source>post of {label}</source>
            <translation>Ausgabe von {label}</translation>
        </message>
        <message>
            <source>recompute the document first</source>
            <translation>zuerst das Dokument neu berechnen</translation>
        </message>
        <message>
            <source>recompute the document to plan the operation</source>
            <translation>das Dokument neu berechnen, um die Operation zu planen</translation>
        </message>
        <message>
            <source>recompute the document, or choose another object</source>
            <translation>das Dokument neu berechnen oder ein anderes Objekt wählen</translation>
        </message>
        <message>
            <source>recompute the operations, and look for their messages</source>
            <translation>die Operationen neu berechnen und ihre Meldungen lesen</translation>
        </message>
        <message>
            <source>remark</source>
            <translation>Bemerkung</translation>
        </message>
        <message>
            <source>rotation {angles} degrees; {least} degrees from the pole</source>
            <translation>Drehung {angles} Grad; {least} Grad vom Pol</translation>
        </message>
        <message>
            <source>select faces of a solid</source>
            <translation>Flächen eines Körpers wählen</translation>
        </message>
        <message>
            <source>select faces of a solid, or convert the mesh to one</source>
            <translation>Flächen eines Körpers wählen oder das Netz in einen umwandeln</translation>
        </message>
        <message>
            <source>select faces of one body; give each body an operation of its own</source>
            <translation>Flächen eines Körpers wählen; jedem Körper eine eigene Operation geben</translation>
        </message>
        <message>
            <source>select faces of the body</source>
            <translation>Flächen des Körpers wählen</translation>
        </message>
        <message>
            <source>select faces, and make one with Five-axis finish</source>
            <translation>Flächen wählen und eine mit Fünfachsig schlichten anlegen</translation>
        </message>
        <message>
            <source>select one of them</source>
            <translation>eines davon wählen</translation>
        </message>
        <message>
            <source>select the faces anew: the model has changed</source>
            <translation>die Flächen neu wählen: das Modell hat sich geändert</translation>
        </message>
        <message>
            <source>select the faces to finish, of one body</source>
            <translation>die zu schlichtenden Flächen eines Körpers wählen</translation>
        </message>
        <message>
            <source>set it in the tool controller</source>
            <translation>sie in der Werkzeugsteuerung setzen</translation>
        </message>
        <message>
            <source>stopped; nothing was changed</source>
            <translation>angehalten; nichts wurde geändert</translation>
        </message>
        <message>
            <source>take a tool of a shape that is: {known}</source>
            <translation>ein Werkzeug einer bekannten Form nehmen: {known}</translation>
        </message>
        <message>
            <source>the Python package trunnion cannot be loaded: {error}</source>
            <translation>das Python-Paket trunnion lässt sich nicht laden: {error}</translation>
        </message>
        <message>
            <source>the document has no five-axis finish</source>
            <translation>das Dokument hat kein fünfachsiges Schlichten</translation>
        </message>
        <message>
            <source>the document has no job</source>
            <translation>das Dokument hat keinen Auftrag</translation>
        </message>
        <message>
            <source>the document has {count} five-axis operations: {labels}</source>
            <translation>das Dokument hat {count} fünfachsige Operationen: {labels}</translation>
        </message>
        <message>
            <source>the document has {count} jobs: {labels}</source>
            <translation>das Dokument hat {count} Aufträge: {labels}</translation>
        </message>
        <message>
            <source>the file has no axes</source>
            <translation>die Datei hat keine Achsen</translation>
        </message>
        <message>
            <source>the file is no machine of FreeCAD: {error}</source>
            <translation>die Datei ist keine Maschine von FreeCAD: {error}</translation>
        </message>
        <message>
            <source>the gauge point is taken at the zero of all axes: enter where the spindle nose stands</source>
            <translation>der Bezugspunkt wird bei null aller Achsen angenommen: eintragen, wo die Spindelnase steht</translation>
        </message>
        <message>
            <source>the machine has the axes {names}; five-axis work needs X, Y, Z and two rotaries</source>
            <translation>die Maschine hat die Achsen {names}; fünfachsig braucht X, Y, Z und zwei Drehachsen</translation>
        </message>
        <message>
            <source>the post processor does not know '{word}'</source>
            <translation>der Postprozessor kennt '{word}' nicht</translation>
        </message>
        <message>
            <source>the whole body</source>
            <translation>der ganze Körper</translation>
        </message>
        <message>
            <source>there is no dialect '{dialect}'</source>
            <translation>es gibt keinen Dialekt '{dialect}'</translation>
        </message>
        <message>
            <source>there is no machine '{source}'</source>
            <translation>es gibt keine Maschine '{source}'</translation>
        </message>
        <message>
            <source>time, s</source>
            <translation>Zeit, s</translation>
        </message>
        <message>
            <source>tool {number} has the lengths {first} and {second} mm</source>
            <translation>Werkzeug {number} hat die Längen {first} und {second} mm</translation>
        </message>
        <message>
            <source>trunnion {version} is too old</source>
            <translation>trunnion {version} ist zu alt</translation>
        </message>
        <message>
            <source>u of the face</source>
            <translation>u der Fläche</translation>
        </message>
        <message>
            <source>unknown</source>
            <translation>unbekannt</translation>
        </message>
        <message>
            <source>up to {limit}</source>
            <translation>bis {limit}</translation>
        </message>
        <message>
            <source>v of the face</source>
            <translation>v der Fläche</translation>
        </message>
        <message>
            <source>wait until it is planned, recompute it, or switch it off with Active</source>
            <translation>warten, bis sie geplant ist, sie neu berechnen oder mit Active abschalten</translation>
        </message>
        <message>
            <source>widest strips</source>
            <translation>breiteste Streifen</translation>
        </message>
        <message>
            <source>write --dialect=NAME</source>
            <translation>--dialect=NAME schreiben</translation>
        </message>
        <message>
            <source>write a number with a unit, such as 0.02 mm</source>
            <translation>eine Zahl mit Einheit schreiben, etwa 0.02 mm</translation>
        </message>
        <message>
            <source>write a number with a unit, such as 1200 mm/min</source>
            <translation>eine Zahl mit Einheit schreiben, etwa 1200 mm/min</translation>
        </message>
        <message>
            <source>write numbers with commas between them</source>
            <translation>Zahlen mit Kommas dazwischen schreiben</translation>
        </message>
        <message>
            <source>wrote {path}</source>
            <translation>{path} geschrieben</translation>
        </message>
        <message>
            <source>wrote {path}: the job's post processor may now be `trunnion`</source>
            <translation>{path} geschrieben: der Postprozessor des Auftrags darf jetzt `trunnion` sein</translation>
        </message>
        <message>
            <source>yes</source>
            <translation>ja</translation>
        </message>
        <message>
            <source>zigzag</source>
            <translation>hin und her</translation>
        </message>
        <message>
            <source>{first} and {second} are different tools with the number {number}</source>
            <translation>{first} und {second} sind verschiedene Werkzeuge mit der Nummer {number}</translation>
        </message>
        <message>
            <source>{label} belongs to no job</source>
            <translation>{label} gehört zu keinem Auftrag</translation>
        </message>
        <message>
            <source>{label} comes from another version of FreeCAD, which keeps jobs elsewhere</source>
            <translation>{label} kommt aus einer anderen Version von FreeCAD, die Aufträge anderswo hält</translation>
        </message>
        <message>
            <source>{label} has no horizontal feed</source>
            <translation>{label} hat keinen horizontalen Vorschub</translation>
        </message>
        <message>
            <source>{label} has no machine</source>
            <translation>{label} hat keine Maschine</translation>
        </message>
        <message>
            <source>{label} has no model</source>
            <translation>{label} hat kein Modell</translation>
        </message>
        <message>
            <source>{label} has no program: {verdict}</source>
            <translation>{label} hat kein Programm: {verdict}</translation>
        </message>
        <message>
            <source>{label} has no shape</source>
            <translation>{label} hat keine Form</translation>
        </message>
        <message>
            <source>{label} has no spindle speed</source>
            <translation>{label} hat keine Spindeldrehzahl</translation>
        </message>
        <message>
            <source>{label} has no tool</source>
            <translation>{label} hat kein Werkzeug</translation>
        </message>
        <message>
            <source>{label} has no tool controller</source>
            <translation>{label} hat keine Werkzeugsteuerung</translation>
        </message>
        <message>
            <source>{label} is a mesh, which has no surfaces</source>
            <translation>{label} ist ein Netz, das keine Flächen hat</translation>
        </message>
        <message>
            <source>{label} is a sketch, which has no faces to cut</source>
            <translation>{label} ist eine Skizze, die keine Flächen zum Fräsen hat</translation>
        </message>
        <message>
            <source>{label} is no job of the CAM workbench</source>
            <translation>{label} ist kein Auftrag des Arbeitsbereichs CAM</translation>
        </message>
        <message>
            <source>{label} is older than the model or its settings</source>
            <translation>{label} ist älter als das Modell oder seine Einstellungen</translation>
        </message>
        <message>
            <source>{label}: the corner radius of the bull-nose is {corner} mm</source>
            <translation>{label}: der Eckenradius des Torusfräsers ist {corner} mm</translation>
        </message>
        <message>
            <source>{label}: tools of the shape {shape} are not placed</source>
            <translation>{label}: Werkzeuge der Form {shape} werden nicht angestellt</translation>
        </message>
        <message>
            <source>{name} is no face of the part, which has {count}</source>
            <translation>{name} ist keine Fläche des Teils, das {count} hat</translation>
        </message>
        <message>
            <source>{name} is not among the {count} faces that the engine reads of the part</source>
            <translation>{name} ist nicht unter den {count} Flächen, die der Rechenkern vom Teil liest</translation>
        </message>
        <message>
            <source>{path} cannot be written: {error}</source>
            <translation>{path} lässt sich nicht schreiben: {error}</translation>
        </message>
        <message>
            <source>{verdict}; {duration} s</source>
            <translation>{verdict}; {duration} s</translation>
        </message>
    </context>
</TS>
